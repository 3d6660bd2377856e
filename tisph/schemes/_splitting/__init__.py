"""The implicit scheme where the flow turns and a pressure arises."""
