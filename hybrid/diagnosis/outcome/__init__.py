"""What follows from the contest: verdict, findings, extended structure, scores, advice."""
