"""Pictures of structures: geometry, layout and, in `render` alone, PyVista."""
