"""The command `hybrid-modal`: one file a sub-command, and the `app` that joins them.

Everything a sub-command computes with is imported when it runs, so that ``--help`` answers at once.
"""
