"""Other hosts on which processes of a launch file run: which there are, and what runs where."""
