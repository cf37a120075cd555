# SPDX-License-Identifier: MIT
"""A contact as an entry of the manifest."""

import numpy as np

from mrts.base.arrays import with_infinity, without_infinity
from mrts.base.manifest import ContactRecord
from mrts.cell.hands.contact import Contact


def contact_record(contact: Contact) -> ContactRecord:
    """What the manifest says of a contact."""
    return ContactRecord(
        name=contact.name,
        frame=contact.frame,
        rows=list(contact.rows),
        units=list(contact.units),
        A=contact.A.tolist(),
        lower=without_infinity(contact.lower),
        upper=without_infinity(contact.upper),
        given=None if contact.given is None else dict(contact.given),
    )


def contact_from_record(record: ContactRecord) -> Contact:
    """The contact that an entry of a manifest describes.

    Raises:
        InputError: If it is none.
    """
    return Contact(
        name=record.name,
        frame=record.frame,
        rows=tuple(record.rows),
        units=tuple(record.units),
        A=np.array(record.A, dtype=np.float64),
        lower=with_infinity(record.lower, -np.inf),
        upper=with_infinity(record.upper, np.inf),
        given=record.given,
    )
