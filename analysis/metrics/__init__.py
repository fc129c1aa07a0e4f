"""The numbers that judge a run, and what is made of them."""
