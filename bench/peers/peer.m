% The recursion on matrices in GNU Octave, for refbench: a line on stdin starts it, seconds a sample and parameters answer.
function theta_and_time(folder)
  read = @(name) fread(fopen([folder "/" name]), 2000, "double");
  heading = read("heading_long");
  rudder = read("rudder_long");
  h = 0.05; lambda = 1.5; x = lambda * h; e = exp(-x);
  begin = cputime();
  theta = zeros(3, 1); P = 1e6 * eye(3);
  A = [e, 0; -x * e, e]; Aq = [e, 0; x * e, e]; Bq = [1 - e; 1 - e - x * e];
  state = [-heading(1); 0]; q = [0; 0];
  for k = 1:numel(heading)
    if k > 1
      state = A * state - [heading(k) - heading(k - 1); 0];
      q = Aq * q + Bq * rudder(k - 1);
    end
    phi = [lambda * state(2); q(2); 1];
    g = P * phi;
    K = g / (1 + phi' * g);
    theta = theta + K * (-lambda ^ 2 * sum(state) - phi' * theta);
    P = P - K * g';
  end
  printf("%.9e %.12e %.12e %.12e\n", (cputime() - begin) / numel(heading), theta);
  fflush(stdout);
end

folder = argv(){end};
% fgetl would wait for the byte after the line.
while ! isempty(byte = fread(stdin, 1))
  if byte == 10
    theta_and_time(folder);
  end
end
