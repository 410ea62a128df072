"""Predict a structure's motion with a trained hybrid model: the same as `hybrid-modal predict`."""

from hybrid.commands.console import standalone
from hybrid.commands.predict import predict

app = standalone(predict)

if __name__ == "__main__":
    app()
