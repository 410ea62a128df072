"""Pages in the folders of results: written after all else, and never at its cost."""

from collections.abc import Callable

from fe_models.files.atomic import write_text
from fe_models.files.result_set import ResultSet
from fe_models.progress import progress_bar
from hybrid.report.page import Page
from hybrid.report.rendering import rendered
from hybrid.result_sets import PAGE


def save_page(results: ResultSet, make: Callable[[], Page]) -> list[str]:
    """Write the page that ``make`` returns beside the other results; return a note where that failed.

    Minutes of work must not be lost for a page: the results before it are whole.
    """
    try:
        with progress_bar("writing the page", 1, "page") as bar:
            text = rendered(make())
            with results.adding() as new:
                write_text(new / PAGE, text)
            bar.update()
    except Exception as error:  # drawings fail in many ways, and none of them is the answer's
        reason = " ".join(str(error).split())
        path = results.folder / PAGE
        return [f"{path} could not be made ({type(error).__name__}: {reason}); the other results are whole"]
    return []
