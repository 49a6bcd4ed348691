% The same scene by the Chicago rules: white highlights, one bounce less, attenuation given.
{ /v /u /face 0.9 0.2 0.1 point 0.4 0.6 30.0 } sphere -1.05 0.0 2.2 translate
{ /v /u /face 0.1 0.2 0.9 point 0.4 0.6 30.0 } sphere 1.05 0.0 2.2 translate union
{ /v /u /face u floor v floor addi 2 modi 0 eqi { 1.0 } { 0.3 } if /c c c c point 1.0 0.0 1.0 }
plane 0.0 -1.0 0.0 translate union /scene
0.0 2.0 0.0 point 3.0 3.0 3.0 point pointlight /bulb
0.3 0.3 0.3 point [ bulb ] 1.0 0.1 0.05 point scene 6 70.0 64 48 "chicago.ppm" render
