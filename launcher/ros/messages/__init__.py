"""Messages of ROS as YAML and back, and the definitions of their types.

`interfaces` finds types, `classes` imports them, `form` is what a type looks like; `decoding` makes
messages of bytes, `from_yaml` and `to_yaml` of text and back; `message_schema` makes one text of a
definition and all that it uses, `idl_text` of IDL.
"""
