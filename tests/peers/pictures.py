"""Pictures as files: OpenEXR with 32-bit floats. In and out: arrays of rows x columns x 3, the first row on top."""

import numpy as np
import OpenEXR


def read_exr(path):
    channels = OpenEXR.File(path).channels()
    return np.array(channels["RGB" if "RGB" in channels else "RGBA"].pixels[..., :3])


def write_exr(path, pixels):
    head = {"compression": OpenEXR.NO_COMPRESSION, "type": OpenEXR.scanlineimage}
    OpenEXR.File(head, {"RGB": np.ascontiguousarray(pixels, np.float32)}).write(path)
