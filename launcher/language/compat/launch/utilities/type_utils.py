"""`launch.utilities.type_utils`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "AllowedTypesTuple": "launcher.language.type_utils",
    "AllowedTypesType": "launcher.language.type_utils",
    "AllowedValueType": "launcher.language.type_utils",
    "ListTypesTuple": "launcher.language.type_utils",
    "ListTypesType": "launcher.language.type_utils",
    "ListValueType": "launcher.language.type_utils",
    "NormalizedScalarType": "launcher.language.type_utils",
    "NormalizedSequenceType": "launcher.language.type_utils",
    "NormalizedValueType": "launcher.language.type_utils",
    "ScalarTypesTuple": "launcher.language.type_utils",
    "ScalarTypesType": "launcher.language.type_utils",
    "ScalarValueType": "launcher.language.type_utils",
    "SequenceValueType": "launcher.language.type_utils",
    "SomeScalarType": "launcher.language.type_utils",
    "SomeSequenceType": "launcher.language.type_utils",
    "SomeValueType": "launcher.language.type_utils",
    "StrSomeScalarType": "launcher.language.type_utils",
    "StrSomeSequenceType": "launcher.language.type_utils",
    "StrSomeValueType": "launcher.language.type_utils",
    "coerce_list": "launcher.language.type_utils",
    "coerce_to_type": "launcher.language.type_utils",
    "extract_type": "launcher.language.type_utils",
    "get_typed_value": "launcher.language.type_utils",
    "is_instance_of": "launcher.language.type_utils",
    "is_instance_of_valid_type": "launcher.language.type_utils",
    "is_normalized_substitution": "launcher.language.type_utils",
    "is_substitution": "launcher.language.type_utils",
    "is_typing_list": "launcher.language.type_utils",
    "is_valid_scalar_type": "launcher.language.type_utils",
    "normalize_typed_substitution": "launcher.language.type_utils",
    "perform_typed_substitution": "launcher.language.type_utils",
}

__all__ = list(_SOURCES)

__getattr__ = reexport(__name__, _SOURCES)
