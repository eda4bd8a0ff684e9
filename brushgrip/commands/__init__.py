"""One file per command: a plain function that typer turns into a command."""
