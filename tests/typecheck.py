"""The type checker of the tests: beartype, with int welcome where float is promised, as in PEP 484."""

from beartype import BeartypeConf, beartype

check = beartype(conf=BeartypeConf(is_pep484_tower=True))
