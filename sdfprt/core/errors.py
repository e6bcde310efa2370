"""The errors that sdfprt raises for a user's input: one base class, and one that carries a place in GLSL; and its warnings."""


class SdfprtError(Exception):
    """A fault in what the user gave: the message names the file, the cause, and what to do."""


class GlslError(SdfprtError):
    """GLSL that does not compile or cannot be used; the message starts with `file:line:` in the user's own lines."""


class SdfprtWarning(UserWarning):
    """What a user should know of what was done with his input; the command line shows these, and no other library's."""
