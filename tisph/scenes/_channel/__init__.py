"""The plane channel: its flow, particles and views, without the types of its config (``channel.py``)."""
