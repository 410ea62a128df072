"""What modes and motion say together: which causes act, in which recordings, and how sure that is."""
