"""References: numbers of known flows, each with its sources, convention and spread, one YAML file a flow."""
