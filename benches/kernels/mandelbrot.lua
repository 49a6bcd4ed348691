return function(face, u, v)
  local cr, ci = u * 3.0 - 2.2, v * 2.4 - 1.2
  local re, im, n = 0.0, 0.0, 0
  while n < 30 do
    local rr, ii = re * re, im * im
    if rr + ii >= 4.0 then break end
    re, im = rr - ii + cr, re * im * 2.0 + ci
    n = n + 1
  end
  local t = n / 30.0
  return t, t * t, 1.0 - t, 0.9, 0.1, 10.0
end
