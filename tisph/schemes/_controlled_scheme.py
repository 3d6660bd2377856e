"""What schemes with steps of a ``StepControl`` have in common."""


class ControlledScheme:
    """Base of such a scheme, whose steps are dense; see ``_protocol.Scheme``.

    ``control``: the ``StepControl``; ``host_names``: attributes that change while the scheme runs.
    """

    host_names = ("time", "steps", "rejected", "shortest", "longest", "order_reduced", "singular")

    @property
    def finished(self):
        """Whether the last target is reached."""
        return self.control.finished

    def set_targets(self, targets):
        """Go on to other targets; return whether the steps so far are those of a run that had them from the start."""
        return self.control.set_targets(targets, self.time)

    def output_times(self, due):
        """Return the times at which there is a snapshot, of those that are ``due``: all, since steps are dense."""
        return due

    def host_state(self):
        """Return the numbers outside the fields that a resumed run needs."""
        return {**{name: getattr(self, name) for name in self.host_names}, **self.control.host_state()}

    def restore_host_state(self, state):
        """Take up the numbers of ``host_state``."""
        vars(self).update({name: state[name] for name in self.host_names})
        self.control.restore_host_state(state)
