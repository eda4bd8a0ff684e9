"""The process of a command: its command line, and what `import brushgrip` offers."""
