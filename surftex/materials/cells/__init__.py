"""Cells: leather grown from particles, joined to cells, and carved."""
