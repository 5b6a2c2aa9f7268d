# SPDX-License-Identifier: LGPL-2.1-or-later
"""judge.py SCHEMA DOCUMENTS: prints a line, 1 or 0, for each line of DOCUMENTS, a JSON document: whether python3-jsonschema
accepts it. Ends with 77 when there is no such module."""

import json
import sys

try:
    import jsonschema
except ImportError:
    sys.exit(77)

with open(sys.argv[1], encoding="utf-8") as file:
    schema = json.load(file)
jsonschema.Draft7Validator.check_schema(schema)
validator = jsonschema.Draft7Validator(schema)
with open(sys.argv[2], encoding="utf-8") as file:
    for line in file:
        print(int(validator.is_valid(json.loads(line))))
