"""QIF documents against a schema: python3 qif.py SCHEMA.xsd DOCUMENT.xml...

Says on stdout what a validator finds, a line each, and "n" and idMax as QIF's CheckFormat.xsl has it; nothing where all is well.
"""

import sys

from lxml import etree

schema = etree.XMLSchema(etree.parse(sys.argv[1]))
for name in sys.argv[2:]:
    document = etree.parse(name)
    if not schema.validate(document):
        for error in schema.error_log:
            print(f"{name}:{error.line}: {error.message}")
    largest = int(document.getroot().get("idMax"))
    for element in document.iter(etree.Element):
        if element.get("n") not in (None, str(len(element))):
            print(f"{name}:{element.sourceline}: n is {element.get('n')}, not {len(element)}")
        if int(element.get("id", 1)) > largest:
            print(f"{name}:{element.sourceline}: id {element.get('id')} is above idMax {largest}")
