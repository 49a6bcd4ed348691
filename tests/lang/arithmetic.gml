% One program a line, and behind `%!` the stack it leaves, or `error CODE at COLUMN`.
1 2 addi %! 3
5 7 subi %! -2
-3 4 muli %! -12
-7 2 divi %! -3
7 -2 divi %! -3
-4 2 divi %! -2
7 2 divi %! 3
-7 2 modi %! -1
7 -2 modi %! 1
5 3 modi %! 2
-6 3 modi %! 0
-8388608 8388607 addi 2 divi 0 eqi %! true
9223372036854775807 1 addi %! error E0301 at 23
-9223372036854775807 2 subi %! error E0301 at 24
4611686018427387904 2 muli %! error E0301 at 23
-9223372036854775808 negi %! error E0301 at 22
-9223372036854775808 -1 divi %! error E0301 at 25
-9223372036854775808 -1 modi %! 0
1 0 divi %! error E0302 at 5
1 0 modi %! error E0302 at 5
5 negi %! -5
3 3 eqi 3 4 eqi %! true false
3 4 lessi 4 3 lessi 3 3 lessi %! true false false
1.5 2.25 addf %! 3.75
1.0 3.0 divf %! 0.3333333333333333
1.0 0.0 divf -1.0 0.0 divf %! inf -inf
0.0 0.0 divf %! NaN
0.0 0.0 divf /n n n eqf n 1.0 lessf 1.0 n lessf %! false false false
-0.0 0.0 eqf %! true
-0.0 negf %! 0.0
0.0 negf %! -0.0
0.1 0.2 addf %! 0.30000000000000004
-2.25 floor -2.25 frac %! -3 -0.25
-0.5 floor 0.5 floor 2.0 floor %! -1 0 2
2.25 frac -0.0 frac %! 0.25 -0.0
1e300 floor %! error E0305 at 7
0.0 0.0 divf floor %! error E0305 at 14
9223372036854775807 real %! 9.223372036854776e18
-1.5 clampf 0.25 clampf 7.0 clampf %! 0.0 0.25 1.0
0.0 0.0 divf clampf %! NaN
2.0 sqrt 0.0 sqrt -0.0 sqrt %! 1.4142135623730951 0.0 -0.0
-1.0 sqrt %! error E0303 at 6
0.0 sin 0.0 cos 90.0 sin 90.0 cos 180.0 sin 180.0 cos %! 0.0 1.0 1.0 0.0 0.0 -1.0
270.0 sin 270.0 cos -90.0 sin -90.0 cos 360.0 sin %! -1.0 0.0 -1.0 0.0 0.0
30.0 sin 60.0 cos 150.0 sin -30.0 sin %! 0.5 0.5 0.5 -0.5
90.0 cos 0.0 eqf %! true
45.0 sin 45.0 cos subf /d d d mulf 1e-30 lessf %! true
0.5 asin 0.5 acos 1.0 asin -1.0 acos 0.0 acos %! 30.0 60.0 90.0 180.0 90.0
2.0 asin -2.0 acos %! NaN NaN
1 2.0 addi %! error E0201 at 7
1.0 2 addf %! error E0201 at 7
1 sin %! error E0201 at 3
true 1 addi %! error E0201 at 8
1.0 floor 1.0 addf %! error E0201 at 15
addi %! error E0101 at 1
1 addi %! error E0101 at 3
-8388608 negi 8388608 eqi %! true
1.0 2.5 subf 3.0 -0.5 mulf %! -1.5 -1.5
7.5 2.5 divf -0.0 1.0 divf %! 3.0 -0.0
1.0 -0.0 divf %! -inf
0.0 0.0 divf negf %! NaN
-0.0 frac -3.0 frac 3.75 frac %! -0.0 -0.0 0.75
1.0 0.0 divf frac %! NaN
0.0 0.0 divf frac %! NaN
-0.0 clampf 1.0 clampf 1.0 0.0 divf clampf %! -0.0 1.0 1.0
-9223372036854775808.0 floor %! -9223372036854775808
9223372036854775808.0 floor %! error E0305 at 23
1.0 0.0 divf floor %! error E0305 at 14
0.0 0.0 divf sqrt 1.0 0.0 divf sqrt %! NaN inf
-1.0 0.0 divf sqrt %! error E0303 at 15
1.0 0.0 divf sin %! NaN
0.0 0.0 divf cos %! NaN
0.0 0.0 divf acos %! NaN
-0.0 sin -0.0 cos %! 0.0 1.0
450.0 sin -450.0 sin 36090.0 cos %! 1.0 -1.0 0.0
-1.0 asin 0.0 asin 1.0 acos %! -90.0 0.0 0.0
1 3 lessi { 2.0 } { 3.0 } if sqrt %! 1.4142135623730951
9007199254740993 real 9007199254740992.0 eqf %! true
-5 -2 divi -5 -2 modi 5 -2 divi %! 2 -1 -2
0 5 divi 0 5 modi 0 -5 modi %! 0 0 0
4 5 muli -4 5 muli addi 0 eqi %! true
1.0 1 eqf %! error E0201 at 7
1 1.0 eqi %! error E0201 at 7
1 2.0 lessf %! error E0201 at 7
