"""What outcomes and robots look like."""
