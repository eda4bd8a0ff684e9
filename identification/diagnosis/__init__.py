"""What a diagnosis says: errors before and after, the effects that were missing, how sure each is."""
