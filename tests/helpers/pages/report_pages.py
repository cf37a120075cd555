"""What a report's page holds, without a browser."""

import gzip
import json
import re
from base64 import b85decode


def data_of(text):
    """What the page draws."""
    packed = re.search(r'<script type="text/plain" id="report-data">(.*?)</script>', text)[1]
    if packed.startswith("{"):  # unpacked by `own_text`
        return json.loads(packed)
    return json.loads(gzip.decompress(b85decode(packed.replace(",", "<"))))


def own_text(text):
    """The page without plotly.js, its data unpacked."""
    page = re.sub(r'(id="plot-library">)[^<]*', r"\1", text)
    packed = re.search(r'id="report-data">([^<]*)', page)[1]
    return page.replace(packed, json.dumps(data_of(text), ensure_ascii=False).replace("<", "\\u003c"))
