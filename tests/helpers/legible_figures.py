"""What can be read of a figure: its texts, where they stand, its curves."""

from itertools import pairwise

from matplotlib.text import Text

SMALLEST = 6.5
"""Letters smaller than this cannot be read in print [pt]."""


def boxes_of_texts(figure):
    """Every text with letters that is drawn, and where it stands [pixels]."""
    figure.draw_without_rendering()
    undrawn = set()
    for axes in figure.axes:
        for number, axis in enumerate((axes.xaxis, axes.yaxis)):
            low, high = sorted(axis.get_view_interval())
            outside = {label for label in axis.get_ticklabels() if not low <= label.get_position()[number] <= high}
            undrawn |= outside if axes.axison else {axis.label, *axis.get_ticklabels()}
    texts = [text for text in figure.findobj(Text) if text.get_visible() and text not in undrawn]
    return {text: text.get_window_extent() for text in texts if text.get_text().strip()}


def check_legible(figure):
    """No letters outside the figure or too small, no legend over the axes, no two labels over each other."""
    boxes = boxes_of_texts(figure)
    page = figure.bbox.padded(1)
    for text, box in boxes.items():
        assert text.get_fontsize() >= SMALLEST, text
        if text.get_clip_on() and text.axes is not None:
            continue
        assert page.x0 <= box.x0, text
        assert box.x1 <= page.x1, text
        assert page.y0 <= box.y0, text
        assert box.y1 <= page.y1, text
    for axes in figure.axes:
        legend = axes.get_legend()
        if legend is not None:
            inside = axes.get_window_extent()
            assert not any(inside.overlaps(boxes[text]) for text in legend.get_texts()), legend.get_texts()
        for ticks in (axes.get_xticklabels(), axes.get_yticklabels()):
            drawn = [boxes[tick] for tick in ticks if tick in boxes]
            for one, other in pairwise(drawn):
                assert not one.padded(-1).overlaps(other.padded(-1)), ticks


def lines_of(axes):
    """Curves of axes by their label."""
    return {line.get_label().strip(): line for line in axes.lines if not line.get_label().startswith("_")}
