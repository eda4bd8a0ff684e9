"""The commands, one file each: plain functions that typer turns into commands; options they share."""
