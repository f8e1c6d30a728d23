"""Mesh files of other programs become a sequence; the command is ../import_sequence.py."""
