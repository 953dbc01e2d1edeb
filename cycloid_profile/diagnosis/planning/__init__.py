"""Sizes that measurements can detect and tell apart, before they are made."""
