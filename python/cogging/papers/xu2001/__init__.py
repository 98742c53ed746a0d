"""Xu and Yao 2001: output-feedback ARC, Table 1."""
