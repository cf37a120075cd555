# SPDX-License-Identifier: MIT
"""The report of a result or a study: one HTML file that opens offline; needs the extra 'report' (plotly).

May import base to output. Start at `page.py`.
"""

from mrts.report.page import report_html, write_report

__all__ = ["report_html", "write_report"]
