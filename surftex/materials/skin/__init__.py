"""Skin: what lies in it and on it, as changes to the biology of every point, then seen by light."""
