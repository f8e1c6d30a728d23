"""Figures of docs/reproducing.md from the records of experiments; the command is ../plot_results.py."""
