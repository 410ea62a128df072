"""The only modules that import Exudyn."""
