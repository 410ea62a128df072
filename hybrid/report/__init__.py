"""Pages that a browser opens: ``report.html`` of a diagnosis, a comparison or a training, whole in one file.

`page` says what a page may show; `rendering` makes HTML of it. What stands on it is made from answers by pure
functions, a file a section. Only commands and notebooks import this package; nothing here decides anything.
"""
