"""What a description is made of: mass properties, joint gains."""
