"""What is made of results folders alone: nothing is flown."""
