"""The functions of a notebook: each takes files or objects, loads what is heavy when it is called, and returns a result
that prints itself.
"""
