"""Time-of-flight cameras by name."""

from __future__ import annotations

from ..description.time_of_flight import TimeOfFlightCamera

#: By name.
TIME_OF_FLIGHT_CAMERAS: dict[str, TimeOfFlightCamera] = {
    "l515": TimeOfFlightCamera(
        name="l515",
        source="Intel RealSense L515 (data sheet, as librealsense issues 5808 and 7236 quote it): field of 70 x 55 "
        "degrees, here at 640x480, 860 nm, 0.25 to 9 m, 9 m on white of reflectance 0.95 in this mode; standard "
        "deviation 2.5 mm at 1 m and 15.5 mm at 9 m; 0.25 mm steps. Assumed: a beam as wide as a pixel, returns told "
        "apart from 0.15 m on, the strongest one reported, 14 mm beside the colour camera",
        place=0.014,
        width=640,
        height=480,
        focal=457.0,
        wavelength=860.0,
        beam=1.0 / 457.0,
        returns="strongest",
        pulse=0.15,
        reach=9.0,
        error=(0.0025, 0.0155),
        range=(0.25, 9.0),
        unit=0.00025,
    ),
}
