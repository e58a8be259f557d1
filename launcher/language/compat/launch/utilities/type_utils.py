"""`launch.utilities.type_utils`, re-exported."""

from launcher.language.compat.names import reexport

_SOURCES = {
    "AllowedTypesTuple": "launcher.language.value_types",
    "AllowedTypesType": "launcher.language.value_types",
    "AllowedValueType": "launcher.language.value_types",
    "ListTypesTuple": "launcher.language.value_types",
    "ListTypesType": "launcher.language.value_types",
    "ListValueType": "launcher.language.value_types",
    "NormalizedScalarType": "launcher.language.value_types",
    "NormalizedSequenceType": "launcher.language.value_types",
    "NormalizedValueType": "launcher.language.value_types",
    "ScalarTypesTuple": "launcher.language.type_utils",
    "ScalarTypesType": "launcher.language.value_types",
    "ScalarValueType": "launcher.language.value_types",
    "SequenceValueType": "launcher.language.value_types",
    "SomeScalarType": "launcher.language.value_types",
    "SomeSequenceType": "launcher.language.value_types",
    "SomeValueType": "launcher.language.value_types",
    "StrSomeScalarType": "launcher.language.value_types",
    "StrSomeSequenceType": "launcher.language.value_types",
    "StrSomeValueType": "launcher.language.value_types",
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
