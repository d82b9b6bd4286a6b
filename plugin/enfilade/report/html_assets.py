# SPDX-License-Identifier: GPL-3.0-or-later
"""Style and the few lines of script of report.html: sorting and searching tables, highlighting a room everywhere. All works without."""

STYLE = """
:root{--ink:#26282b;--soft:#5b626b;--faint:#6a7078;--rule:#d9d7d0;--paper:#fbfaf6;--sheet:#fff;
--rust:#9a3412;--link:#1f6f8b;--line:#eceae4;--chip:#f4efe4;--tag:#ecebe6;--hot:#fdf3dc;--error:#f3d0c7;
--warning:#fcebc4;--grazing:#f8d28e;--unproven:#d8e8ee;color-scheme:light dark}
@media screen and (prefers-color-scheme:dark){:root{--ink:#e8e6e1;--soft:#a9adb3;--faint:#969ba2;--rule:#3c3f44;--paper:#1c1d1f;
--sheet:#242629;--link:#7cc0d8;--line:#303338;--chip:#35342f;--tag:#3a3c40;--hot:#3d3626;--error:#6b2f22;--warning:#5a4a1d;
--grazing:#6b4a12;--unproven:#274753}}
*{box-sizing:border-box}
html{scroll-behavior:smooth}
body{margin:0;background:var(--paper);color:var(--ink);font:15px/1.5 "Helvetica Neue",Helvetica,Arial,"DejaVu Sans",sans-serif;
font-variant-numeric:tabular-nums}
main,header,nav>div{max-width:1240px;margin:0 auto;padding:0 32px}
header{padding-top:48px;padding-bottom:20px}
h1{font-size:40px;line-height:1.1;margin:0 0 6px;letter-spacing:-.02em;font-weight:600;overflow-wrap:anywhere}
h2{font-size:24px;margin:64px 0 6px;letter-spacing:-.01em;font-weight:600;border-top:2px solid var(--ink);padding-top:14px}
h3{font-size:17px;margin:36px 0 8px;font-weight:600;overflow-wrap:anywhere}
p{max-width:76ch;margin:6px 0 12px}
h3+.sub{max-width:none}
.sub,.note,figcaption{color:var(--soft)}
.note{font-size:13.5px}
nav{position:sticky;top:0;background:var(--paper);border-bottom:1px solid var(--rule);z-index:2}
nav>div{display:flex;flex-wrap:wrap;gap:4px 20px;padding-top:9px;padding-bottom:9px;font-size:13.5px}
nav a{color:var(--soft);text-decoration:none}
nav a:hover{color:var(--ink);text-decoration:underline}
h2,h3{scroll-margin-top:48px}
.figures{display:flex;flex-wrap:wrap;gap:14px 40px;margin:24px 0 8px;padding:0;list-style:none}
.figures li{min-width:84px}
.figures b{display:block;font-size:28px;line-height:1.15;font-weight:600;letter-spacing:-.01em}
.figures span{font-size:13px;color:var(--soft)}
.plans{display:grid;grid-template-columns:repeat(auto-fill,minmax(min(100%,560px),1fr));gap:20px;margin:18px 0}
.plans.few{grid-template-columns:minmax(0,1040px)}
a{color:var(--link)}
figure{margin:0;background:#fff;color:#26282b;border:1px solid var(--rule);padding:6px;break-inside:avoid;color-scheme:only light}
figure svg,figure img{display:block;width:100%;height:auto}
figure.matrix div{margin:0 auto}
p.key{max-width:none}
table.full{width:100%}
table.full td{max-width:none}
table.full td:last-child{columns:2 420px;column-gap:24px}
table.full td:last-child div{break-inside:avoid;padding-left:14px;text-indent:-14px}
table.tight{font-size:13px}table.tight th,table.tight td{padding:5px 6px}
td details{margin:2px 0}td ul{margin:2px 0;padding-left:18px}
.files{columns:3 300px;column-gap:24px;font-size:13.5px;margin:4px 0;padding:0;list-style:none}.files li{overflow-wrap:anywhere;break-inside:avoid}
dl.counters{columns:3 300px;column-gap:40px;display:block;max-width:none}.counters dt{float:left;clear:left;font-weight:400}.counters dd{text-align:right;break-before:avoid}
.printed{display:none}
:focus-visible{outline:2px solid var(--link);outline-offset:2px}
td.one{min-width:110px;max-width:200px;overflow-wrap:anywhere}
figure.matrix img{width:auto;max-width:100%;margin:0 auto;image-rendering:pixelated}
.plans figure,.tall{content-visibility:auto;contain-intrinsic-block-size:auto 640px}
figcaption{font-size:13px;padding:4px 8px}
.key{display:flex;flex-wrap:wrap;gap:4px 20px;font-size:13px;color:var(--soft);margin:8px 0}
.key i{display:inline-block;width:13px;height:13px;margin-right:6px;vertical-align:-2px;border:1px solid #0002}
.wide{overflow-x:auto;margin:10px 0 6px}
.tall{max-height:80vh;overflow-y:auto}.tall th{position:sticky;top:0}
.find{display:block;margin:10px 0 6px;padding:6px 10px;width:min(100%,320px);font:inherit;font-size:13.5px;color:var(--ink);
background:var(--sheet);border:1px solid var(--rule);border-radius:3px}
table{border-collapse:collapse;font-size:13.5px;background:var(--sheet);border:1px solid var(--rule);min-width:50%}
th,td{padding:5px 10px;text-align:left;vertical-align:top;border-bottom:1px solid var(--line);overflow-wrap:break-word;max-width:420px}
th{font-weight:600;border-bottom:1.5px solid var(--ink);white-space:nowrap;background:var(--sheet)}
th small{display:block;font-weight:400;color:var(--faint)}
td.n,th.n{text-align:right}
tr:last-child td{border-bottom:0}
table.sort th{cursor:pointer}
table.sort th[aria-sort=ascending]::after{content:" \\2191"}
table.sort th[aria-sort=descending]::after{content:" \\2193"}
.way b{white-space:nowrap}
.way b{font-weight:500;background:var(--chip);border-radius:3px;padding:0 5px}
.way i{color:var(--faint);font-style:normal;padding:0 3px}
.none{color:var(--faint)}
.tag{display:inline-block;font-size:12px;border-radius:3px;padding:0 6px;background:var(--tag);color:var(--ink)}
.tag.error{background:var(--error)}.tag.warning{background:var(--warning)}.tag.grazing{background:var(--grazing)}.tag.unproven{background:var(--unproven)}
details{margin:10px 0}summary{cursor:pointer;color:var(--soft)}
dl{display:grid;grid-template-columns:max-content 1fr;gap:4px 18px;font-size:13.5px;margin:8px 0}
dt{font-weight:600}dd{margin:0;color:var(--soft)}
[data-room].hot{stroke:var(--rust);stroke-width:3}
tr.hot td{background:var(--hot)}
footer{max-width:1240px;margin:72px auto 0;padding:16px 32px 48px;border-top:1px solid var(--rule);color:var(--faint);font-size:13px}
@media (max-width:640px){main,header,nav>div{padding-left:16px;padding-right:16px}h1{font-size:30px}.plans{grid-template-columns:minmax(0,1fr)}dl{grid-template-columns:1fr}
figure{overflow-x:auto}.plans figure svg{min-width:600px}nav>div{flex-wrap:nowrap;overflow-x:auto;white-space:nowrap}.figures{gap:12px 26px}}
@media print{.plans figure,.tall{content-visibility:visible}nav,.find,.screen,details:not([open]){display:none}.printed{display:block}
.long tr:nth-child(n+61){display:none}.tall{max-height:none;overflow:visible}body{background:#fff;font-size:10.5pt}
main,header,footer{max-width:none;padding:0}footer{margin-top:24px}h2{margin-top:28px;break-after:avoid}
h3,p.sub,p.key{break-after:avoid;break-inside:avoid}.plans{break-before:avoid}figure{border:0;padding:0}figure svg,figure img{max-height:96mm}
p{break-inside:avoid}h2+p{break-after:avoid}
.plans{grid-template-columns:1fr 1fr;gap:8px}.plans.few{grid-template-columns:1fr}.wide{overflow:visible}table{font-size:8.5pt;border:0}
table.tight{font-size:7pt}table.tight th{white-space:normal}table.tight th,table.tight td{padding:2px 3px}
th,td{padding:2px 5px}tr{break-inside:avoid}*{print-color-adjust:exact;-webkit-print-color-adjust:exact}}
"""

SCRIPT = """
"use strict";
document.querySelectorAll("table.sort").forEach(function(table){
  var head=table.tHead;if(!head||!table.tBodies.length)return;
  Array.prototype.forEach.call(head.rows[0].cells,function(cell,column){
    cell.tabIndex=0;
    function sort(){
      var up=cell.getAttribute("aria-sort")!=="ascending";
      Array.prototype.forEach.call(head.rows[0].cells,function(c){c.removeAttribute("aria-sort")});
      cell.setAttribute("aria-sort",up?"ascending":"descending");
      var body=table.tBodies[0],rows=Array.prototype.slice.call(body.rows).map(function(r,i){
        var c=r.cells[column],v=c.dataset.v!==undefined?c.dataset.v:c.textContent.trim();return{r:r,v:v,n:parseFloat(v),i:i}});
      rows.sort(function(a,b){
        var ea=a.v==="",eb=b.v==="";if(ea!==eb)return ea?1:-1;
        var o=!isNaN(a.n)&&!isNaN(b.n)?a.n-b.n:a.v.localeCompare(b.v,undefined,{numeric:true});
        return (up?o:-o)||a.i-b.i});
      rows.forEach(function(x){body.appendChild(x.r)});
    }
    cell.addEventListener("click",sort);
    cell.addEventListener("keydown",function(e){if(e.key==="Enter"||e.key===" "){e.preventDefault();sort()}});
  });
});
document.querySelectorAll("table.long").forEach(function(table){
  var box=document.createElement("input"),frame=table.parentNode;
  box.className="find";box.type="search";box.placeholder="Find in "+table.tBodies[0].rows.length.toLocaleString("en")+" rows";
  box.setAttribute("aria-label",box.placeholder);frame.parentNode.insertBefore(box,frame);
  box.addEventListener("input",function(){
    var words=box.value.toLowerCase().split(/\\s+/).filter(Boolean);
    Array.prototype.forEach.call(table.tBodies[0].rows,function(r){
      var text=r.textContent.toLowerCase();
      r.hidden=!words.every(function(w){return text.indexOf(w)>=0})})});
});
(function(){
  var byRoom={};
  document.querySelectorAll("[data-room]").forEach(function(e){(byRoom[e.dataset.room]=byRoom[e.dataset.room]||[]).push(e)});
  var hot=null;
  function mark(room,on){(byRoom[room]||[]).forEach(function(e){e.classList.toggle("hot",on)})}
  document.addEventListener("mouseover",function(e){
    var t=e.target.closest&&e.target.closest("[data-room]"),room=t?t.dataset.room:null;
    if(room===hot)return;if(hot!==null)mark(hot,false);hot=room;if(room!==null)mark(room,true);
  });
})();
"""
