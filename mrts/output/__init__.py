# SPDX-License-Identifier: MIT
"""A result as files: saved, as tables and bags, for a controller, as films, as a report (one HTML file, opens offline).

May import base to starting. Start at `saved_result.py`; `report_page.py` needs the extra 'report' (plotly, Jinja).
"""
