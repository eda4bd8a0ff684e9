"""Result of a diagnosis: errors before and after, the missing effects, how sure each is."""
