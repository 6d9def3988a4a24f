import "./page.css";
import { openShell } from "./shell.ts";
import { showTheme } from "./theme.ts";

showTheme();
openShell(document.body);
