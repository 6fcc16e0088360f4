"""The digital TWIN simulates two coaxial ER clutches on a ball screw."""
