"""`--picture FILE` of the examples: what they print, drawn (python3-matplotlib)."""


def picture_option(arguments):
    """(the arguments without it, FILE or None)"""
    if "--picture" not in arguments:
        return arguments, None
    at = arguments.index("--picture")
    if at + 1 >= len(arguments):
        raise SystemExit("--picture needs a file, as picture.png")
    return arguments[:at] + arguments[at + 2:], arguments[at + 1]


def new_picture(title, columns=1, **axes):
    """(figure, its axes); drawn into files, without a screen."""
    try:
        import matplotlib
    except ImportError:
        raise SystemExit("--picture needs matplotlib: apt install python3-matplotlib") from None
    matplotlib.use("Agg")
    from matplotlib import pyplot
    figure, places = pyplot.subplots(1, columns, figsize=(4.2 * columns + 2, 4.2), layout="constrained",
                                     subplot_kw=axes)
    figure.suptitle(title)
    return figure, places


def save_picture(figure, file):
    figure.savefig(file, dpi=100)
