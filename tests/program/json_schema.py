"""A validator for the part of JSON Schema that docs/output.schema.json uses. Other parts of JSON Schema are errors."""

KNOWN = {"type", "properties", "required", "additionalProperties", "items", "enum", "const", "minimum", "anyOf", "$ref",
         "description"}


def of_type(value, name):
    if name == "integer":
        return isinstance(value, int) and not isinstance(value, bool)
    if name == "number":
        return isinstance(value, (int, float)) and not isinstance(value, bool)
    return isinstance(value, {"object": dict, "array": list, "string": str, "boolean": bool, "null": type(None)}[name])


def problems(value, schema, definitions, where="$"):
    """Yields a text for each violation of the schema by the value."""
    if unknown := set(schema) - KNOWN:
        raise ValueError(f"{where}: the schema has {unknown}")
    if "$ref" in schema:
        yield from problems(value, definitions[schema["$ref"].removeprefix("#/$defs/")], definitions, where)
        return
    if "anyOf" in schema:
        if not any(not list(problems(value, one, definitions, where)) for one in schema["anyOf"]):
            yield f"{where}: {value!r} is none of those allowed"
        return
    if "const" in schema and value != schema["const"]:
        yield f"{where}: {value!r} is not {schema['const']!r}"
    if "enum" in schema and value not in schema["enum"]:
        yield f"{where}: {value!r} is none of {schema['enum']}"
    types = schema.get("type", [])
    types = [types] if isinstance(types, str) else types
    if types and not any(of_type(value, name) for name in types):
        yield f"{where}: {value!r} is no {' or '.join(types)}"
        return
    if "minimum" in schema and value is not None and value < schema["minimum"]:
        yield f"{where}: {value!r} is below {schema['minimum']}"
    if isinstance(value, dict):
        yield from problems_of_object(value, schema, definitions, where)
    if isinstance(value, list) and "items" in schema:
        for index, item in enumerate(value):
            yield from problems(item, schema["items"], definitions, f"{where}[{index}]")


def problems_of_object(value, schema, definitions, where):
    for key in schema.get("required", []):
        if key not in value:
            yield f"{where}: {key} is missing"
    others = schema.get("additionalProperties", True)
    for key, item in value.items():
        if key in schema.get("properties", {}):
            yield from problems(item, schema["properties"][key], definitions, f"{where}.{key}")
        elif others is False:
            yield f"{where}: {key} is not in the schema"
        elif isinstance(others, dict):
            yield from problems(item, others, definitions, f"{where}.{key}")
