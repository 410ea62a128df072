"""What a hybrid model learns on the nominal and on the extended structure."""
