"""A network and a solver taken away: ONNX, TorchScript, or one header of C."""
