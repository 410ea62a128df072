"""What the product is measured against, each in the same run; `hybrid-modal benchmark` prints it."""
