"""Further targets of `erclutch export`: C++, ONNX, FMU 2 and 3, Simulink, MuJoCo; each writes or wraps the C."""
