"""Messages of topics, services, actions and recordings."""


class Message:
    """A message, its fields as attributes: message.header.stamp, message.position.

    Whole and floating numbers, bool and str are Python's; an enum is its value's name. Repeated
    numbers and bytes are read-only NumPy arrays that view the message without a copy; other
    repeated fields are lists, maps dicts. None: not set. `message["name"]` is the same as
    `message.name`; `type_name` is the protobuf name of its type.
    """

    __slots__ = ("type_name", "_fields")

    def __init__(self, type_name, fields):
        self.type_name = type_name
        self._fields = fields

    def __getattr__(self, name):
        if name == "_fields":  # while it is copied or unpickled
            raise AttributeError(name)
        try:
            return self._fields[name]
        except KeyError:
            raise AttributeError(
                f"{self.type_name} has no field '{name}'; it has {', '.join(self._fields)}"
            ) from None

    def __getitem__(self, name):
        return self._fields[name]

    def __iter__(self):
        return iter(self._fields)

    def __contains__(self, name):
        return name in self._fields

    def __dir__(self):
        return [*super().__dir__(), *self._fields]

    def to_dict(self):
        """The fields as a dict, messages within it as well."""
        def plain(value):
            if isinstance(value, Message):
                return value.to_dict()
            if isinstance(value, list):
                return [plain(one) for one in value]
            if isinstance(value, dict):
                return {key: plain(one) for key, one in value.items()}
            return value
        return {name: plain(value) for name, value in self._fields.items()}

    def __repr__(self):
        def short(value):
            if hasattr(value, "shape") and value.size > 8:
                return f"<{value.size} x {value.dtype}>"
            if isinstance(value, list) and len(value) > 4:
                return f"<{len(value)} values>"
            return repr(value)
        set_ones = (f"{n}={short(v)}" for n, v in self._fields.items() if v is not None)
        return f"{self.type_name.rsplit('.', 1)[-1]}({', '.join(set_ones)})"
