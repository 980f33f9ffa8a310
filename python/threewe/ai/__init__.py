"""Learned policies: a folder with a description and an ONNX graph, that drives a robot through the safety gate."""

from threewe.ai.folder import CameraInput, Policy, Quantity, read_policy
from threewe.ai.runner import PolicyResult, VLARunner

__all__ = ["CameraInput", "Policy", "PolicyResult", "Quantity", "VLARunner", "read_policy"]
