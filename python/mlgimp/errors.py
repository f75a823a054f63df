"""The exceptions of the package: one line that says what is wrong and what is allowed, for people to read."""


class Error(Exception):
    """Something that the user can put right; its text is one line."""


class ResultError(Error):
    """A file or folder that is not what it should be; the line begins with its path."""

    def __init__(self, path, problem):
        super().__init__(f"{path}: {problem}")
        self.problem = problem


class RunError(Error):
    """A run of the program that did not reach its end; the text is the program's one line."""


class Interrupted(KeyboardInterrupt):
    """A run that the user has stopped; the text says where its results are and how to go on."""
