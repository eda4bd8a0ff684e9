"""The results of a diagnosis: the page, lines on the screen, and the folder."""
