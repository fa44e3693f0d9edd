"""Rigs: what they are and how motion fits them; foot plan, locked feet, ground, head and hands."""
