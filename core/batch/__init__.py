"""Many bakes: which recordings, how long they take, and how they came out."""
